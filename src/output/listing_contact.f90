!> Contacts in the log: their description before the first step, and after each step the resultants
!! of both sides, the balance with the supports, and the states of the points.
!!
!! With HALFpass each side integrates its own tractions, so the two resultants differ by the
!! discretisation error, which their relative sum shows. With MORTar, BALAnced or a rigid side the
!! forces are opposite; the moments are opposite too, up to an error of tangential force times
!! penetration. In a step without inertia, the forces of supports, contacts and loads add up to zero
!! within the residual of the step.
module listing_contact
  use base_kinds, only: wp
  use base_log, only: log_line
  use base_text, only: to_text
  use contact_pair, only: contact_t, surface_t, option_text
  use contact_resultant, only: resultant_t, side_resultant
  use contact_type, only: PENALTY, MU, TANGENTIAL_PENALTY
  use model, only: model_t, state_t
  use tensor, only: cross
  implicit none
  private
  public :: list_contact, contact_size, list_contacts

  real(wp), parameter :: ORIGIN(3) = 0.0_wp !! point about which moments are taken

contains

  !> List the surfaces, the points, and the laws with their numbers and sources.
  subroutine list_contact(contact)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text
    integer :: i

    call log_line('contact   '//contact_size(contact))
    associate (normal => contact%normal)
      text = 'normal '//trim(normal%law%name)//' '//to_text(normal%prop(PENALTY))
      if (allocated(normal%account)) text = text//' ('//normal%account//')'
      call log_line('          '//text//option_text(contact))
      call log_line('          '//trim(normal%law%source))
    end associate
    if (contact%friction%given) then
      associate (friction => contact%friction)
        text = 'friction '//trim(friction%law%name)//' '//to_text(friction%prop(MU)) &
               //', penalty '//to_text(friction%prop(TANGENTIAL_PENALTY))
        if (contact%after > -huge(1.0_wp)) text = text//', in steps that start at ' &
                                                  //to_text(contact%after)//' or later'
        call log_line('          '//text)
        call log_line('          '//trim(friction%law%source))
      end associate
    end if
    if (contact%cohesive%given) then
      associate (cohesive => contact%cohesive)
        text = 'cohesive '//trim(cohesive%law%name)
        do i = 1, cohesive%law%nprop
          text = text//' '//to_text(cohesive%prop(i))
        end do
        if (cohesive%law%option /= '') text = text//' '//trim(cohesive%law%option)
        if (cohesive%tau > 0.0_wp) text = text//', viscous with time '//to_text(cohesive%tau)
        text = text//', released at opening '//to_text(contact%released(1))
        if (abs(contact%released(2) - contact%released(1)) > 0.0_wp) then
          text = text//' (normal) or '//to_text(contact%released(2))//' (shear)'
        end if
        call log_line('          '//text)
        call log_line('          '//trim(cohesive%law%source))
      end associate
    end if
    text = 'depth '//to_text(contact%depth)
    if (contact%default_depth) text = text//' (half the thickness of the thinner body)'
    call log_line('          '//text)
  end subroutine list_contact

  !> Name of a contact and sizes of its surfaces, such as
  !! `'sole': hemi 3- (9 elements, 225 points), block 3+ (4 elements, rigid)`.
  function contact_size(contact) result(text)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text

    text = "'"//contact%name//"': "//side(contact%side(1))
    if (contact%self) then
      text = text//' with itself'
    else
      text = text//', '//side(contact%side(2))
    end if

  contains

    function side(s) result(part)
      type(surface_t), intent(in) :: s
      character(:), allocatable :: part

      part = s%name//' ('//to_text(s%nelem)//trim(merge(' element ', ' elements', s%nelem == 1)) &
             //', '
      if (s%rigid) then
        part = part//'rigid)'
      else
        part = part//to_text(s%nelem*contact%nplain)//' points'
        if (contact%ncell > 1) part = part//', '//to_text(contact%nq - contact%nplain) &
                                      //' in a refined element'
        part = part//')'
      end if
    end function side
  end function contact_size

  !> Write two lines for each contact and one for the supports; nothing if there are no contacts.
  subroutine list_contacts(model, state, f_ext)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: f_ext(:, :)         !! (3, nnode) loads [F]
    type(resultant_t) :: side(2), both, all_sides
    real(wp) :: force(3), moment(3), load(3), load_moment(3), r(3), x(3)
    real(wp) :: force_size, moment_size
    character(:), allocatable :: without
    integer :: c, k, n

    if (size(model%contact) == 0) return
    do c = 1, size(model%contact)
      both = resultant_t()
      do k = 1, 2
        call side_resultant(model, state, c, k, ORIGIN, side(k))
        call add(side(k), both)
        call add(side(k), all_sides)
      end do
      associate (name => model%contact(c)%name)
        call log_line('contact '//name//': force on side 1'//vector(side(1)%force)//', on side 2' &
                      //vector(side(2)%force)//', relative sum' &
                      //ratio(both%force, both%force_size/2)//'; moments' &
                      //vector(side(1)%moment)//' and'//vector(side(2)%moment)//', relative sum' &
                      //ratio(both%moment, both%moment_size/2))
        n = merge(1, 2, model%contact(c)%self)
        call log_line(repeat(' ', len('contact '//name))//'  '//closed_text(side(:n)))
      end associate
    end do
    force = 0.0_wp
    moment = 0.0_wp
    load = 0.0_wp
    load_moment = 0.0_wp
    force_size = all_sides%force_size/2 ! each force acts on two bodies, or is that of a support
    moment_size = all_sides%moment_size/2
    do n = 1, model%mesh%nnode
      if (.not. model%mesh%used(n)) cycle
      x = model%mesh%xr(:, n) + state%u(:, n) - ORIGIN
      r = merge(state%reaction(:, n), 0.0_wp, model%eq(:, n) == 0)
      force = force + r
      moment = moment + cross(x, r)
      load = load + f_ext(:, n)
      load_moment = load_moment + cross(x, f_ext(:, n))
      force_size = force_size + 0.5_wp*(norm2(r) + norm2(f_ext(:, n)))
      moment_size = moment_size + 0.5_wp*(norm2(cross(x, r)) + norm2(cross(x, f_ext(:, n))))
    end do
    load = load + force + all_sides%force
    load_moment = load_moment + moment + all_sides%moment
    without = ''
    if (state%dynamics%on) without = ', without the forces of inertia'
    call log_line('supports: force'//vector(force)//', moment'//vector(moment)//'; sum with ' &
                  //'contacts and loads'//without//': relative force'//ratio(load, force_size) &
                  //', relative moment'//ratio(load_moment, moment_size))
  end subroutine list_contacts

  !> The state of the points of both sides or, in self-contact, of the only side. The cells of
  !! MORTar can touch where no integration point lies.
  pure function closed_text(side) result(text)
    type(resultant_t), intent(in) :: side(:)
    character(:), allocatable :: text

    if (all(side%nclosed == 0) .and. .not. any(side%area > 0.0_wp)) then
      text = 'nothing is in contact'
      return
    end if
    text = 'in contact '//text_of(side%nclosed)//' of '//text_of(side%npoint)//' points: stick ' &
           //text_of(side%nstick)//', slip '//text_of(side%nslip)
    if (all(side%nclosed == 0)) text = 'in contact between the integration points'
    text = text//', area'//number(side(1)%area)
    if (size(side) > 1) text = text//number(side(2)%area)
    text = text//', largest penetration'//number(maxval(side%penetration))
  end function closed_text

  pure subroutine add(part, whole)
    type(resultant_t), intent(in) :: part
    type(resultant_t), intent(inout) :: whole

    whole%force = whole%force + part%force
    whole%moment = whole%moment + part%moment
    whole%force_size = whole%force_size + part%force_size
    whole%moment_size = whole%moment_size + part%moment_size
  end subroutine add

  !> The norm of the sum of two forces or moments, relative to their mean size; 0 if this is zero.
  pure function ratio(total, size) result(text)
    real(wp), intent(in) :: total(3), size
    character(:), allocatable :: text

    text = ' 0'
    if (size > 0.0_wp) text = number(norm2(total)/size)
  end function ratio

  pure function vector(v) result(text)
    real(wp), intent(in) :: v(3)
    character(:), allocatable :: text
    character(40) :: field

    write (field, '(3es12.4e2)') v
    text = trim(field)
  end function vector

  pure function number(v) result(text)
    real(wp), intent(in) :: v
    character(:), allocatable :: text
    character(16) :: field

    write (field, '(es10.2e2)') v
    text = ' '//trim(adjustl(field))
  end function number

  !> The numbers of both sides as text; in self-contact, that of the only side.
  pure function text_of(n) result(text)
    integer, intent(in) :: n(:)
    character(:), allocatable :: text

    text = to_text(n(1))
    if (size(n) > 1) text = text//' + '//to_text(n(2))
  end function text_of

end module listing_contact
